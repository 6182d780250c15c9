// SPDX-License-Identifier: GPL-3.0-or-later
/* Preloaded into a program, keeps it from going on to main: it waits there, loaded, and every request that
   comes by its socket becomes a copy of it that does go on. Of a short run nearly all the time goes into
   loading two hundred libraries.

   SIGNORINI_RESIDENT  number of an inherited SOCK_SEQPACKET socket

   A request is one message: int32 argc, int32 count of the environment's entries, then the folder to run in,
   the arguments and the environment, each ended by a zero byte; with it come the descriptors of stdin, stdout
   and stderr. The answers are two int32: the process, and when it has ended its status as waitpid() gives it.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

typedef int Main(int, char**, char**);

enum { most_bytes = 1 << 17, most_words = 4096, descriptors = 3, failed = 125 };

static Main* program;

/* Of another preloaded library, if there is one: reads the environment anew. */
extern void signorini_preloaded(void) __attribute__((weak));
static char request[most_bytes];

/* Receives a request; its number of bytes, 0 when there will be no more. */
static ssize_t receive(int socket, int fds[descriptors]) {
  union {
    char bytes[CMSG_SPACE(sizeof(int) * descriptors)];
    struct cmsghdr aligned;
  } control;
  struct iovec data = {request, sizeof request - 1};
  struct msghdr message = {
      .msg_iov = &data, .msg_iovlen = 1, .msg_control = control.bytes, .msg_controllen = sizeof control};
  const ssize_t size = recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
  if (size <= 0)
    return 0;
  const struct cmsghdr* header = CMSG_FIRSTHDR(&message);
  if (!header || header->cmsg_len != CMSG_LEN(sizeof(int) * descriptors) ||
      message.msg_flags & (MSG_TRUNC | MSG_CTRUNC))
    _exit(failed);
  memcpy(fds, CMSG_DATA(header), sizeof(int) * descriptors);
  return size;
}

/* What the request asks for, in a copy of the waiting process. */
static int go_on(ssize_t size, const int fds[descriptors]) {
  static char* words[most_words];
  int32_t counts[2];
  memcpy(counts, request, sizeof counts);
  char *at = request + sizeof counts, *end = request + size;
  const char* folder = at;
  at += strlen(at) + 1;
  const int argc = counts[0], count = counts[0] + counts[1];
  if (argc < 1 || count >= most_words || chdir(folder) != 0)
    _exit(failed);
  clearenv();
  for (int i = 0; i < count && at < end; ++i, at += strlen(at) + 1)
    if (i < argc)
      words[i] = at;
    else
      putenv(at);
  for (int i = 0; i < descriptors; ++i)
    if (dup2(fds[i], i) < 0)
      _exit(failed);
  if (signorini_preloaded)
    signorini_preloaded();
  return program(argc, words, environ);
}

static int serve(int argc, char** argv, char** environment) {
  (void)argc, (void)argv, (void)environment;
  const int socket = atoi(getenv("SIGNORINI_RESIDENT"));
  int fds[descriptors];
  for (ssize_t size; (size = receive(socket, fds)) > 0;) {
    const int32_t process = fork();
    if (process == 0) {
      close(socket);
      return go_on(size, fds);
    }
    for (int i = 0; i < descriptors; ++i)
      close(fds[i]);
    int status = 0;
    if (process < 0 || write(socket, &process, sizeof process) < 0 || waitpid(process, &status, 0) < 0 ||
        write(socket, &status, sizeof status) < 0)
      _exit(failed);
  }
  _exit(0);
}

typedef int Start(Main*, int, char**, Main*, void (*)(void), void (*)(void), void*);

/* What the C library runs in place of main. */
int __libc_start_main(Main* main, int argc, char** argv, Main* init, void (*fini)(void), void (*loader)(void),
                      void* stack) {
  Start* start = (Start*)dlsym(RTLD_NEXT, "__libc_start_main");
  program = main;
  return start(getenv("SIGNORINI_RESIDENT") ? serve : main, argc, argv, init, fini, loader, stack);
}
