% MDL_PLANAR3  A planar arm of three links of 1 m, p3, with its posture qz.
p3 = robot({link([0 1 0 0 0]), link([0 1 0 0 0]), link([0 1 0 0 0])}, 'three link');
qz = [0 0 0];
