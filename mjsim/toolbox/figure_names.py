"""Names of figure functions that Octave records instead of opening windows, and of those that need user input."""

DRAWN = (
    *("figure", "subplot", "axes", "hold", "clf", "cla", "close", "closereq", "set", "gca", "newplot", "delete"),
    *("plot", "plot3", "line", "semilogx", "semilogy", "loglog", "stairs", "stem", "bar", "area", "errorbar"),
    *("fill", "patch", "quiver", "polar", "scatter", "scatter3", "surf", "mesh", "contour", "surfc", "meshc"),
    *("surface", "surfl", "meshz", "contour3", "stem3", "fill3", "bar3", "quiver3", "trisurf", "trimesh", "triplot"),
    *(
        "comet",
        "comet3",
        "ribbon",
        "waterfall",
        "xline",
        "yline",
        "viscircles",
        "animatedline",
        "addpoints",
        "clabel",
        "spy",
    ),
    *("compass", "feather", "rose", "boxplot"),
    *("title", "xlabel", "ylabel", "zlabel", "legend", "text", "grid", "axis", "xlim", "ylim", "zlim", "view"),
    *("imshow", "image", "imagesc", "pcolor", "contourf", "histogram", "pie", "barh", "rectangle", "polarplot"),
    *("xticks", "yticks", "xticklabels", "yticklabels", "xtickangle", "ytickangle", "caxis", "clim", "yyaxis"),
    *("tiledlayout", "nexttile", "daspect", "colormap", "colorbar", "print", "saveas", "exportgraphics", "savefig"),
    *("hgsave", "sgtitle", "suptitle", "hgexport", "export_fig", "annotation", "sgrid", "zgrid"),
)
"""Functions that have an effect on a picture."""
WITHOUT_EFFECT = (
    *("drawnow", "pause", "waitbar", "rotate3d", "camproj", "lighting", "material", "light", "hidden", "zoom"),
    *("pan", "shading", "box", "refresh", "camlight", "lightangle", "diffuse"),
    *("specular", "campos", "camtarget", "camup", "camva", "camzoom", "camorbit", "camroll", "camlookat", "pbaspect"),
    *("linkaxes", "linkprop", "uicontrol", "uimenu", "uipanel", "uibuttongroup", "uitable", "uicontextmenu", "msgbox"),
    *("warndlg", "errordlg", "helpdlg", "movegui", "hgtransform", "hggroup", "uistack", "copyobj", "orient", "shg"),
    *("whitebg", "brighten", "xtickformat", "ytickformat", "ztickformat", "ztickangle", "rticks", "thetaticks"),
    *("refreshdata", "rotate", "guidata", "uiwait", "uiresume", "setappdata", "movie", "alpha"),
    *("clearpoints", "commandwindow", "beep", "axtoolbar", "disableDefaultInteractivity", "figurepalette"),
    *("plotbrowser", "propertyeditor", "iptsetpref", "tightfig", "opengl", "colordef", "datacursormode", "brush"),
)
"""Functions without effect on a picture, or about windows."""
NOT_DRAWN = (
    *("datetick", "gtext", "pareto", "plotmatrix", "slice", "streamline", "streamtube"),
    *("streamribbon", "stemleaf", "isocaps", "tetramesh", "pie3", "surfnorm", "semilogxerr", "semilogyerr"),
    *("loglogerr", "swarmchart", "heatmap", "geoplot", "parallelcoords", "boxchart", "bubblechart", "quiverc"),
    *("stackedplot", "histogram2", "bar3h", "streamslice", "contourslice", "coneplot", "fimplicit3", "wordcloud"),
)
"""Functions that are recorded but not drawn."""
FIGURE_FUNCTIONS = (*DRAWN, *WITHOUT_EFFECT, *NOT_DRAWN)
"""All functions that are recorded."""
INTERACTIVE = (
    *("ginput", "waitforbuttonpress", "input", "keyboard", "menu", "uigetfile", "uiputfile", "uigetdir"),
    *("inputdlg", "listdlg", "questdlg", "uisetfont", "uisetcolor", "getpts", "getrect", "drawpolygon", "impoint"),
)
"""Functions that wait for a person."""
