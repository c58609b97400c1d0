function [R, t] = tr2rt(T)
% TR2RT  Rotation and position of a pose: [R, t] = tr2rt(T).
  n = rows(T) - 1;
  R = T(1:n, 1:n, :); t = squeeze(T(1:n, end, :));
end
