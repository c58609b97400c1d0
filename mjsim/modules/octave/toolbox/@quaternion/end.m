function n = end(q, varargin)
% END  The number of the last quaternion.
  n = size(q.rows, 1);
end
