function [indices, map] = rgb2ind(image_, varargin)
% RGB2IND  Indices into a colour map; a picture of getframe stays as it is.
  if mjsim_frame(image_) > 0, indices = image_; map = zeros(0, 3); return, end
  pixels = reshape(double(image_), [], 3); if isinteger(image_), pixels = pixels / 255; end
  levels = 5; cells = round(pixels * levels);
  [map, ~, k] = unique(cells, 'rows'); map = map / levels;
  indices = reshape(uint8(k - 1), size(image_, 1), size(image_, 2));
end
