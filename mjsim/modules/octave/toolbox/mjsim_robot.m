function [r, rest] = mjsim_robot(given)
% MJSIM_ROBOT  The arm among arguments in either order, and the others.
%   An arm is an object, robot.arms.NAME of a module, or a matrix [alpha A theta D sigma].
  found = find(cellfun(@(a) isa(a, 'robot') || (isstruct(a) && isfield(a, 'before')), given), 1);
  if isempty(found)
    found = find(cellfun(@(a) isnumeric(a) && size(a, 2) >= 4 && ndims(a) == 2 && size(a, 1) > 1, given), 1);
    if isempty(found)
      error('no arm is given; make one with robot(L) or SerialLink(L)');
    end
    r = robot(given{found});
  else
    r = given{found};
  end
  rest = given([1:found - 1, found + 1:end]);
end
