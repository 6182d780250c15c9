// SPDX-License-Identifier: GPL-3.0-or-later
// J and the norm of its gradient at the first guess of a scene: own SCENE [key=value…]
#include "app/problem.h"
#include "base/threads.h"
#include <cstdio>
