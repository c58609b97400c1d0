% MDL_PLANAR1  A planar arm of one link of 1 m, p1, with its postures qz and qn.
p1 = robot({link([0 1 0 0 0])}, 'one link');
qz = 0;
qn = pi/4;
