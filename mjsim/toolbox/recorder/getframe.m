function frame = getframe(varargin)
% GETFRAME  Stands for the figure as it is now: mjsim draws it after the script has ended. Its first bytes name it.
  if nargin > 0 && isnumeric(varargin{1}) && ~isaxes(varargin{1}) && varargin{1} == fix(varargin{1}), figure(varargin{1}); end
  id = mjsim_record('getframe', {});
  frame = struct('cdata', zeros(420, 560, 3, 'uint8'), 'colormap', []);
  frame.cdata(1, 1:8, 1) = [77 74 83 70, mod(floor(id ./ 256 .^ (3:-1:0)), 256)];
end
