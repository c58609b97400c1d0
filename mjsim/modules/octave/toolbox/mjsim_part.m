function v = mjsim_part(T, name)
% MJSIM_PART  A part of a pose, 4 x 4, as its SE3 object has it; a field of that name of any other variable.
  if ~isnumeric(T), v = T.(name); return, end
  switch name
    case 't', v = reshape(T(1:3, 4, :), 3, [])'; if rows(v) == 1, v = v'; end
    case 'R', v = T(1:3, 1:3, :);
    case 'inv', v = inv(T);
    otherwise, v = T;
  end
end
