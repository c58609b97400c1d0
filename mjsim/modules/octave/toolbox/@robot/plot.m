function varargout = plot(r, q, varargin)
% PLOT  Draws an arm at joint values, a row for each posture.
  h = mjsim_record('robot', [{mjsim_plain(r), double(q)}, r.plotopt(:)', varargin]);
  if nargout > 0, varargout{1} = h; end
end
