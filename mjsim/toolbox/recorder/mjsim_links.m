function links = mjsim_links(r)
% MJSIM_LINKS  The links of an arm: of a function's result, unlike of an object's field, Octave gives all values.
  links = r.links;
end
