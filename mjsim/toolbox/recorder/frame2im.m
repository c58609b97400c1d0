function [image_, map] = frame2im(frame)
% FRAME2IM  The picture of a frame.
  image_ = frame.cdata; map = frame.colormap;
end
