% MDL_STANFORD  The Stanford arm, stanf, with its posture qz; its third joint slides.
stanf = robot({link([-pi/2 0 0 0.412 0]), link([pi/2 0 0 0.154 0]), link([0 0 -pi/2 0 1]), ...
               link([-pi/2 0 0 0 0]), link([pi/2 0 0 0 0]), link([0 0 0 0.263 0])}, 'Stanford arm');
stanf.links(3).qlim = [0.3048 1.27];
qz = [0 0 0 0 0 0];
