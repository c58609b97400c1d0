function s = mjsim_plain(r)
% MJSIM_PLAIN  The fields of an arm as a struct.
  s = struct('links', {r.links}, 'name', r.name, 'base', r.base, 'tool', r.tool, 'gravity', r.gravity(:)');
end
