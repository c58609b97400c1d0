function [q, err, flag, info] = ikcon(r, T, q0, varargin)
% IKCON  Joint values within limits that bring the tool to a pose, from q0 or other starts: ikcon(r, T, q0).
  bounds = r.qlim; s = mjsim_chain(r); n = r.n; q = zeros(size(T, 3), n); err = zeros(size(T, 3), 1);
  if nargin < 3 || isempty(q0), q0 = mean(bounds, 2)'; end
  turning = find(~s.slide); seed = 1; info = '';
  for k = 1:size(T, 3)
    err(k) = Inf; start = q0(:)';
    for try_ = 1:20
      [found, miss] = mjsim_ikine(s, T(:, :, k), start, ones(6, 1));
      found(turning) = found(turning) - 2 * pi * floor((found(turning) - bounds(turning, 1)') / (2 * pi) + 1e-12);
      outside = any(found < bounds(:, 1)' - 1e-9 | found > bounds(:, 2)' + 1e-9);
      if miss + outside < err(k), q(k, :) = found; err(k) = miss + outside; end
      if err(k) < 1e-9, break, end
      for n_ = 1:n
        seed = mod(16807 * seed, 2147483647);
        start(n_) = bounds(n_, 1) + seed / 2147483647 * diff(bounds(n_, :));
      end
    end
    q0 = q(k, :);
  end
  flag = err < 1e-9;
  if any(~flag)
    warning('mjsim:ikine', 'within its limits the tool does not reach %d of %d poses', sum(~flag), numel(flag));
  end
end
