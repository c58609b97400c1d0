% PUMA560  The Puma 560 with the masses of Armstrong, Khatib and Burdick (1986): p560, and qz, qr, qn, qstretch.
mjsim_L = {link([pi/2 0 0 0 0]), link([0 0.4318 0 0 0]), link([-pi/2 0.0203 0 0.15005 0]), ...
           link([pi/2 0 0 0.4318 0]), link([-pi/2 0 0 0 0]), link([0 0 0 0 0])};
mjsim_m = [0 17.4 4.8 0.82 0.34 0.09];
mjsim_r = [0 0 0; -0.3638 0.006 0.2275; -0.0203 -0.0141 0.070; 0 0.019 0; 0 0 0; 0 0 0.032];
mjsim_I = [0 0.35 0; 0.13 0.524 0.539; 0.066 0.086 0.0125; 1.8e-3 1.3e-3 1.8e-3; 0.3e-3 0.4e-3 0.3e-3; ...
           0.15e-3 0.15e-3 0.04e-3];
mjsim_Jm = [200e-6 200e-6 200e-6 33e-6 33e-6 33e-6];
mjsim_G = [-62.6111 107.815 -53.7063 76.0364 71.923 76.686];
mjsim_B = [1.48e-3 0.817e-3 1.38e-3 71.2e-6 82.6e-6 36.7e-6];
mjsim_T = [0.395 -0.435; 0.126 -0.071; 0.132 -0.105; 11.2e-3 -16.9e-3; 9.26e-3 -14.5e-3; 3.96e-3 -10.5e-3];
mjsim_q = [-160 160; -45 225; -225 45; -110 170; -100 100; -266 266] * pi / 180;
for mjsim_k = 1:6
  mjsim_L{mjsim_k}.m = mjsim_m(mjsim_k);
  mjsim_L{mjsim_k}.r = mjsim_r(mjsim_k, :);
  mjsim_L{mjsim_k}.I = diag(mjsim_I(mjsim_k, :));
  mjsim_L{mjsim_k}.Jm = mjsim_Jm(mjsim_k);
  mjsim_L{mjsim_k}.G = mjsim_G(mjsim_k);
  mjsim_L{mjsim_k}.B = mjsim_B(mjsim_k);
  mjsim_L{mjsim_k}.Tc = mjsim_T(mjsim_k, :);
  mjsim_L{mjsim_k}.qlim = mjsim_q(mjsim_k, :);
end
p560 = robot(mjsim_L, 'Puma 560', 'Unimation');
qz = [0 0 0 0 0 0];
qr = [0 pi/2 -pi/2 0 0 0];
qn = [0 pi/4 pi 0 pi/4 0];
qs = [0 0 -pi/2 0 0 0];
qstretch = qs;
clear mjsim_L mjsim_m mjsim_r mjsim_I mjsim_Jm mjsim_G mjsim_B mjsim_T mjsim_q mjsim_k
