function frame = getframe(varargin)
% GETFRAME  An empty picture: figures are drawn after the script has ended.
  frame = struct('cdata', zeros(420, 560, 3, 'uint8'), 'colormap', []);
end
