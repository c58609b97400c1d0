function q = UnitQuaternion(varargin)
% UNITQUATERNION  As quaternion, of length 1; UnitQuaternion(s, v) has these parts; UnitQuaternion.Rx(0.3), .rpy([r p y]).
  if nargin == 2 && numel(varargin{2}) == 3, varargin = {[varargin{1}, varargin{2}(:)']}; end
  q = unit(quaternion(varargin{:}));
end
