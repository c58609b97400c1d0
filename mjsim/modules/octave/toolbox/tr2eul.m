function eul = tr2eul(T, varargin)
% TR2EUL  Euler's angles phi, theta, psi of a pose, a row for each; in degrees with 'deg'.
  eul = zeros(size(T, 3), 3);
  for k = 1:size(T, 3)
    R = T(1:3, 1:3, k);
    phi = 0;
    if hypot(R(1, 3), R(2, 3)) > 1e-12, phi = atan2(R(2, 3), R(1, 3)); end
    theta = atan2(cos(phi) * R(1, 3) + sin(phi) * R(2, 3), R(3, 3));
    psi = atan2(-sin(phi) * R(1, 1) + cos(phi) * R(2, 1), -sin(phi) * R(1, 2) + cos(phi) * R(2, 2));
    eul(k, :) = [phi theta psi];
  end
  [unused, scale] = mjsim_deg(varargin);
  eul = eul / scale;
end
