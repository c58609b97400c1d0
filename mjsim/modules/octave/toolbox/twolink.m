% TWOLINK  A planar arm of two links of 1 m and 1 kg: tl, and qz, qn.
mjsim_L = {link([0 1 0 0 0]), link([0 1 0 0 0])};
for mjsim_k = 1:2
  mjsim_L{mjsim_k}.m = 1;
  mjsim_L{mjsim_k}.r = [-0.5 0 0];
end
tl = robot(mjsim_L, 'Simple two link', 'of a book');
qz = [0 0];
qn = [pi/6, -pi/6];
clear mjsim_L mjsim_k
