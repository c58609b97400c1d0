% MDL_TWOLINK  The planar arm of two links: twolink, and qz, qn.
eval('twolink');
twolink = tl;
