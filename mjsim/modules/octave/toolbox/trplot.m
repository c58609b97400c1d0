function h = trplot(T, varargin)
% TRPLOT  Draws frames of poses or rotations: trplot(T, 'frame', 'A', 'color', 'r', 'length', 0.5, 'axis', [...]).
  if rows(T) == 3, R = T; T = repmat(eye(4), [1 1 size(R, 3)]); T(1:3, 1:3, :) = R; end
  [w, rest] = mjsim_words(varargin, struct('frame', '', 'color', 'b', 'length', 1, 'axis', [], 'text_opts', {{}}, ...
                          'thick', 0.5, 'labels', 'XYZ', 'view', [], 'handle', [], 'axhandle', []));
  colors = {w.color, w.color, w.color};
  if any(strcmp(rest, 'rgb')) || any(strcmp(rest, 'rviz')), colors = {'r', 'g', 'b'}; end
  hold('on');
  for i = 1:size(T, 3)
    o = T(1:3, 4, i);
    for k = 1:3
      e = o + w.length * T(1:3, k, i);
      h = plot3([o(1) e(1)], [o(2) e(2)], [o(3) e(3)], colors{k}, 'LineWidth', max(w.thick, 1));
      name = w.labels(k);
      if ~isempty(w.frame), name = [name '_{' w.frame '}']; end
      text(e(1), e(2), e(3), name);
    end
    if ~isempty(w.frame), text(o(1), o(2), o(3), ['{' w.frame '}']); end
  end
  if ~isempty(w.axis), axis(w.axis); end
  if ~isempty(w.view), view(w.view); end
  grid('on'); xlabel('X'); ylabel('Y'); zlabel('Z');
end
