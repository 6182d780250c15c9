# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages, figures and films of the results of a run, a study or a batch in its folder::

    from signorini.post import report
    from signorini.post.run_folder import RunFolder

The package needs the files of the run and no compiled module. Its scripts can also be called by their files, such as
postprocess/report.py.
"""
