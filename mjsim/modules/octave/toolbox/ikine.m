function [q, err] = ikine(varargin)
% IKINE  Joint values that bring the tool to a pose: ikine(r, T, q0, M); a row for each pose of 4 x 4 x k.
%   M weights x, y, z and the rotation about them; 0 for free coordinates.
  [r, rest] = mjsim_robot(varargin);
  s = mjsim_chain(r);
  n = numel(s.m);
  T = rest{1}; q0 = zeros(1, n); M = ones(6, 1); numbers = 0; k = 2;
  while k <= numel(rest)
    if ischar(rest{k}) && any(strcmp(rest{k}, {'mask', 'q0'}))
      if strcmp(rest{k}, 'mask'), M = rest{k + 1}(:); else, q0 = rest{k + 1}(:)'; end
      k = k + 1;
    elseif ischar(rest{k}) && any(strcmp(rest{k}, {'pinv', 'nopinv', 'varstep', 'novarstep', 'quiet', 'verbose', ...
                                                   'search', 'notsearch', 'plot', 'transpose'}))
      % How it iterates is ours: only the pose that it reaches counts.
    elseif ischar(rest{k})
      if ~any(strcmp(rest{k}, {'tol', 'ilimit', 'rlimit', 'slimit', 'alpha', 'lambda', 'lambdamin'}))
        error('ikine has no option ''%s''; it has mask and q0', rest{k});
      end
      k = k + 1;
    elseif isnumeric(rest{k}) && ~isempty(rest{k})
      if numel(rest{k}) == 6 && numbers > 0, M = rest{k}(:); else, q0 = rest{k}(:)'; end
      numbers = numbers + 1;
    end
    k = k + 1;
  end
  q = zeros(size(T, 3), n); err = zeros(size(T, 3), 1);
  for k = 1:size(T, 3)
    [q(k, :), err(k)] = mjsim_ikine(s, T(:, :, k), q0, M);
    q0 = q(k, :);
  end
  if any(err > 1e-9)
    warning('mjsim:ikine', 'the tool does not reach %d of %d poses: the nearest values are returned', ...
            sum(err > 1e-9), numel(err));
  end
end
