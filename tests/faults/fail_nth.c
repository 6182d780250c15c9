// SPDX-License-Identifier: GPL-3.0-or-later
/* Preloaded into a program, lets the n-th of the calls that change a folder fail, as a full or a broken disk
   does.

   SIGNORINI_FAIL_UNDER  calls count on paths below this folder
   SIGNORINI_FAIL_AT     the number of the call that fails, from 1; 0: none
   SIGNORINI_FAIL_FROM   1: all from there on
   SIGNORINI_FAIL_ERROR  errno, such as 28 (ENOSPC); or kill: the process is killed in place of the call; or
   interrupt: it gets a SIGINT and the call goes through SIGNORINI_FAIL_LOG    a file that takes a line for
   every call: its number, its name, the path below the folder

   Of several ranks the first. Calls of the C library from within itself do not come by, so that its own
   functions which make them (fopen, fwrite, fclose, mkdtemp, mkstemp) are watched too. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdio_ext.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static pid_t process; /* the one that counts: copies of it (gmsh's) do not */
static char under[PATH_MAX];
static long at, count;
static int from, error, signal_sent, log_file = -1;

/* Reads the environment: when it is loaded, and once more in a copy of a waiting program (resident.c). */
__attribute__((constructor)) void signorini_preloaded(void) {
  const char *folder = getenv("SIGNORINI_FAIL_UNDER"), *rank = getenv("OMPI_COMM_WORLD_RANK");
  if (!folder || (rank && atoi(rank) != 0) || !realpath(folder, under))
    return;
  const char *number = getenv("SIGNORINI_FAIL_AT"), *what = getenv("SIGNORINI_FAIL_ERROR"),
             *log = getenv("SIGNORINI_FAIL_LOG");
  at = number ? atol(number) : 0;
  from = getenv("SIGNORINI_FAIL_FROM") != NULL;
  signal_sent = !what ? 0 : strcmp(what, "kill") == 0 ? SIGKILL : strcmp(what, "interrupt") == 0 ? SIGINT : 0;
  error = what ? atoi(what) : ENOSPC;
  if (log)
    log_file = (int)syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  process = getpid();
}

/* Whether a call on an absolute path fails. */
static int fails(const char* call, const char* path) {
  const size_t length = strlen(under);
  if (process == 0 || process != getpid() || strncmp(path, under, length) != 0 ||
      (path[length] != '/' && path[length] != 0))
    return 0;
  ++count;
  if (log_file >= 0) {
    char line[PATH_MAX + 64];
    const int size =
        snprintf(line, sizeof line, "%ld %s %s\n", count, call, path[length] ? path + length + 1 : ".");
    syscall(SYS_write, log_file, line, (size_t)size);
  }
  if (at == 0 || !(count == at || (from && count > at)))
    return 0;
  if (signal_sent) {
    kill(process, signal_sent);
    return 0;
  }
  errno = error;
  return 1;
}

static int fails_by_name(const char* call, int folder, const char* path) {
  char whole[2 * PATH_MAX] = "";
  if (path[0] != '/') {
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", folder);
    if (folder == AT_FDCWD ? !getcwd(whole, PATH_MAX) : readlink(link, whole, PATH_MAX - 1) < 0)
      return 0;
    strcat(whole, "/");
  }
  strncat(whole, path, PATH_MAX - 1);
  return fails(call, whole);
}

static int fails_by_file(const char* call, int file) {
  char link[64], path[PATH_MAX] = "";
  const int before = errno;
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  if (readlink(link, path, sizeof path - 1) < 0) {
    errno = before;
    return 0;
  }
  return fails(call, path);
}

static mode_t mode_of(int flags, va_list rest) {
  return flags & (O_CREAT | O_TMPFILE) ? (mode_t)va_arg(rest, unsigned) : 0;
}

#define OPEN(name)                                                                                           \
  int name(const char* path, int flags, ...) {                                                               \
    va_list rest;                                                                                            \
    va_start(rest, flags);                                                                                   \
    const mode_t mode = mode_of(flags, rest);                                                                \
    va_end(rest);                                                                                            \
    return fails_by_name(flags & O_CREAT ? "create" : "open", AT_FDCWD, path)                                \
               ? -1                                                                                          \
               : REAL(name)(path, flags, mode);                                                              \
  }
OPEN(open)
OPEN(open64)

#define OPENAT(name)                                                                                         \
  int name(int folder, const char* path, int flags, ...) {                                                   \
    va_list rest;                                                                                            \
    va_start(rest, flags);                                                                                   \
    const mode_t mode = mode_of(flags, rest);                                                                \
    va_end(rest);                                                                                            \
    return fails_by_name(flags & O_CREAT ? "create" : "open", folder, path)                                  \
               ? -1                                                                                          \
               : REAL(name)(folder, path, flags, mode);                                                      \
  }
OPENAT(openat)
OPENAT(openat64)

#define CREAT(name)                                                                                          \
  int name(const char* path, mode_t mode) {                                                                  \
    return fails_by_name("create", AT_FDCWD, path) ? -1 : REAL(name)(path, mode);                            \
  }
CREAT(creat)
CREAT(creat64)

#define FOPEN(name)                                                                                          \
  FILE* name(const char* restrict path, const char* restrict mode) {                                         \
    return fails_by_name(mode[0] == 'r' ? "open" : "create", AT_FDCWD, path) ? NULL                          \
                                                                             : REAL(name)(path, mode);       \
  }
FOPEN(fopen)
FOPEN(fopen64)

ssize_t write(int file, const void* data, size_t size) {
  return fails_by_file("write", file) ? -1 : REAL(write)(file, data, size);
}
ssize_t writev(int file, const struct iovec* parts, int n) {
  return fails_by_file("write", file) ? -1 : REAL(writev)(file, parts, n);
}
ssize_t pwrite(int file, const void* data, size_t size, off_t place) {
  return fails_by_file("write", file) ? -1 : REAL(pwrite)(file, data, size, place);
}
ssize_t pwrite64(int file, const void* data, size_t size, off64_t place) {
  return fails_by_file("write", file) ? -1 : REAL(pwrite64)(file, data, size, place);
}
size_t fwrite(const void* restrict data, size_t size, size_t n, FILE* restrict file) {
  return fails_by_file("write", fileno(file)) ? 0 : REAL(fwrite)(data, size, n, file);
}
int fclose(FILE* file) {
  const int writes = __fwriting(file) && __fpending(file) > 0 && fails_by_file("write", fileno(file)),
            before = errno;
  if (writes)
    __fpurge(file);
  const int closed = REAL(fclose)(file);
  if (!writes)
    return closed;
  errno = before;
  return EOF;
}
int fsync(int file) { return fails_by_file("sync", file) ? -1 : REAL(fsync)(file); }
int ftruncate(int file, off_t size) {
  return fails_by_file("write", file) ? -1 : REAL(ftruncate)(file, size);
}
int ftruncate64(int file, off64_t size) {
  return fails_by_file("write", file) ? -1 : REAL(ftruncate64)(file, size);
}

int rename(const char* old, const char* new) {
  return fails_by_name("rename", AT_FDCWD, new) ? -1 : REAL(rename)(old, new);
}
int renameat(int from, const char* old, int to, const char* new) {
  return fails_by_name("rename", to, new) ? -1 : REAL(renameat)(from, old, to, new);
}
int mkdir(const char* path, mode_t mode) {
  return fails_by_name("mkdir", AT_FDCWD, path) ? -1 : REAL(mkdir)(path, mode);
}
int mkdirat(int folder, const char* path, mode_t mode) {
  return fails_by_name("mkdir", folder, path) ? -1 : REAL(mkdirat)(folder, path, mode);
}
char* mkdtemp(char* path) { return fails_by_name("mkdir", AT_FDCWD, path) ? NULL : REAL(mkdtemp)(path); }
int mkstemp(char* path) { return fails_by_name("create", AT_FDCWD, path) ? -1 : REAL(mkstemp)(path); }
int unlink(const char* path) { return fails_by_name("remove", AT_FDCWD, path) ? -1 : REAL(unlink)(path); }
int unlinkat(int folder, const char* path, int flags) {
  return fails_by_name("remove", folder, path) ? -1 : REAL(unlinkat)(folder, path, flags);
}
int rmdir(const char* path) { return fails_by_name("remove", AT_FDCWD, path) ? -1 : REAL(rmdir)(path); }
int remove(const char* path) { return fails_by_name("remove", AT_FDCWD, path) ? -1 : REAL(remove)(path); }
