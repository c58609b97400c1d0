function jsingu(J)
% JSINGU  Prints which columns of a Jacobian depend on others.
  [R, independent] = rref(J, 1e-9);
  for k = setdiff(1:columns(J), independent)
    on = independent(abs(R(1:numel(independent), k)) > 1e-9);
    printf('column %d depends on: %s\n', k, strjoin(arrayfun(@num2str, on, 'UniformOutput', false), ' '));
  end
end
