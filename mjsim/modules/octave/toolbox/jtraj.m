function [q, qd, qdd] = jtraj(q0, q1, t, qd0, qd1)
% JTRAJ  Quintics from one posture to another: [q, qd, qdd] = jtraj(q0, q1, t, qd0, qd1); a number stands for steps.
%   jtraj(r, T0, T1, t) moves an arm between the postures of two poses.
  if isa(q0, 'robot')
    r = q0; poses = cat(3, q1, t); t = qd0;
    try, ends = ikine6s(r, poses); catch, ends = ikine(r, poses); end
    [q, qd, qdd] = jtraj(ends(1, :), ends(2, :), t);
    return
  end
  if isscalar(t)
    length_ = 1; s = (0:t - 1)' / (t - 1);
  else
    t = t(:); length_ = t(end) - t(1); s = (t - t(1)) / length_;
  end
  q0 = q0(:)'; q1 = q1(:)';
  v0 = zeros(size(q0)); v1 = v0;
  if nargin > 3, v0 = qd0(:)' * length_; end
  if nargin > 4, v1 = qd1(:)' * length_; end
  d = q1 - q0;
  a = 6 * d - 3 * (v1 + v0); b = -15 * d + 8 * v0 + 7 * v1; c = 10 * d - 6 * v0 - 4 * v1;
  q = s.^5 * a + s.^4 * b + s.^3 * c + s * v0 + ones(size(s)) * q0;
  qd = (5 * s.^4 * a + 4 * s.^3 * b + 3 * s.^2 * c + ones(size(s)) * v0) / length_;
  qdd = (20 * s.^3 * a + 12 * s.^2 * b + 6 * s * c) / length_^2;
end
