function q = subsasgn(q, s, p)
% SUBSASGN  Puts quaternions at places: q(2) = p.
  if ~strcmp(s(1).type, '()') || numel(s) > 1, error('parts of a quaternion are not set; make a new one'); end
  q.rows(s(1).subs{1}, :) = quaternion(p).rows;
end
