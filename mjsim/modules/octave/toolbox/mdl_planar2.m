% MDL_PLANAR2  A planar arm of two links of 1 m, p2, with its postures qz and qn.
p2 = robot({link([0 1 0 0 0]), link([0 1 0 0 0])}, 'two link');
qz = [0 0];
qn = [0 pi/3];
