# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages, figures and films of what a run or a study left in its folder::

    from signorini.post import report
    from signorini.post.run_folder import RunFolder

It needs the files of the run and no compiled module. Its scripts are called by their files, too: postprocess/report.py.
"""
