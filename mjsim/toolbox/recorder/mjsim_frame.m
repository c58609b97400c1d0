function id = mjsim_frame(image_)
% MJSIM_FRAME  The number of the call of getframe that gave a picture; 0 for any other picture.
  id = 0;
  if isa(image_, 'uint8') && isequal(size(image_), [420 560 3]) && isequal(image_(1, 1:4, 1), uint8([77 74 83 70]))
    id = sum(double(image_(1, 5:8, 1)) .* 256 .^ (3:-1:0));
  end
end
