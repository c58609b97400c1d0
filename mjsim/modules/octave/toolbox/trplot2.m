function h = trplot2(T, varargin)
% TRPLOT2  Draws the frame of a pose in the plane, 3 x 3: trplot2(T, 'frame', 'A', 'color', 'r').
  if rows(T) == 2, T = [T [0; 0]; 0 0 1]; end
  w = mjsim_words(varargin, struct('frame', '', 'color', 'b', 'length', 1, 'axis', []));
  hold('on');
  o = T(1:2, 3); names = 'XY';
  for k = 1:2
    e = o + w.length * T(1:2, k);
    h = plot([o(1) e(1)], [o(2) e(2)], w.color, 'LineWidth', 1.5);
    text(e(1), e(2), [names(k) '_{' w.frame '}']);
  end
  if ~isempty(w.axis), axis(w.axis); end
  axis('equal'); grid('on');
end
