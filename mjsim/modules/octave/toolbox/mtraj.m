function [q, qd, qdd] = mtraj(one, q0, q1, t)
% MTRAJ  Paths of several values, each by tpoly or lspb: [q, qd, qdd] = mtraj(@lspb, q0, q1, t).
  for k = 1:numel(q0)
    [q(:, k), qd(:, k), qdd(:, k)] = one(q0(k), q1(k), t);
  end
end
