"""The guarded reader: untrusted files are decoded in a child process with limits, which hands back plain values.

A file that crashes its decoder, never ends, or unpacks to gigabytes becomes one line and exit code 2, whatever library
reads it; exploiting a bug in such a library gives access to neither the network nor other files. One call:

    points = guarded("PACKAGE.matrices:matrices", path, about=path)

runs `matrices(path)` there and returns its value: None, bool, int, float, str, bytes, arrays of numbers, and lists,
tuples and dictionaries of these. A generator function yields its values as they are made:

    for part in guarded_parts("PACKAGE.logs:batches", path, about=path): ...

A `Reader` keeps the child for many calls, as importing the libraries costs more than decoding a small file:

    with Reader("PACKAGE.pictures:read") as reader:
        for name, data in files.items():
            picture = reader.call("PACKAGE.pictures:read", data, about=name, size=len(data))

Arguments may be any values that can be pickled. The functions may read what is below `folders` (by default the folder
of the file), write nothing unless `scratch` gives them a private folder for temporary files, and start no programs.
They import what they need themselves; imports at the top of their module are loaded before the limits hold.
"""

from mjsim.faces import face

__getattr__, __dir__, __all__ = face(__name__, __file__)
