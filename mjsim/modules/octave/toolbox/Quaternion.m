function q = Quaternion(varargin)
% QUATERNION  As quaternion; Quaternion(s, v) is of an angle and an axis, as in toolbox 9, told in a line.
  if nargin == 2 && isnumeric(varargin{2})
    warning('Quaternion(s, v): s is taken as an angle, v as its axis, as in toolbox 9; write [s v] for the parts');
  end
  q = quaternion(varargin{:});
end
