function tranimate(varargin)
% TRANIMATE  Draws a frame that moves, at some of its poses: tranimate(T1, T2), tranimate(T), 'nsteps', n.
  [w, rest] = mjsim_words(varargin, struct('nsteps', 50, 'fps', 10, 'axis', [], 'frame', '', 'color', 'b'));
  poses = rest(cellfun(@isnumeric, rest));
  for k = 1:numel(poses)
    if rows(poses{k}) == 3, poses{k} = r2t(poses{k}); end
  end
  if numel(poses) > 1
    T = ctraj(poses{1}, poses{2}, w.nsteps);
  elseif size(poses{1}, 3) > 1
    T = poses{1};
  else
    T = ctraj(eye(4), poses{1}, w.nsteps);
  end
  shown = unique(round(linspace(1, size(T, 3), min(6, size(T, 3)))));
  for k = shown
    given = {};
    if k == shown(end), given = {'frame', w.frame}; end
    trplot(T(:, :, k), 'color', w.color, given{:});
  end
  p = squeeze(T(1:3, 4, :));
  plot3(p(1, :), p(2, :), p(3, :), 'k:');
  if ~isempty(w.axis), axis(w.axis); end
end
