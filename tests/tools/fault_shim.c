/* Makes calls on files fail as a full or broken disk does. Preloaded by fault_test.py:
 *   DEEPSLAM_FAULT_BELOW   folder whose files are meant
 *   DEEPSLAM_FAULT_AT      number of the call that fails, from 1; 0: none
 *   DEEPSLAM_FAULT_ERROR   ENOSPC: that call and all later ones that need space; EIO: that call alone
 *   DEEPSLAM_FAULT_CALLS   write (default) or read: which calls are counted and fail
 *   DEEPSLAM_FAULT_COUNT   file that gets the number of calls and the kind of the failed one at the end
 * Calls that write: open for writing, mkdir, write, writev, pwrite, fsync, rename. Calls that read: read, readv, pread. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static char below[PATH_MAX];
static long fail_at = 0;
static int fail_error = EIO;
static int of_reads = 0;
static long num_calls = 0;
static const char* failed_call = "none";
static char count_file[PATH_MAX];

static ssize_t (*next_read)(int, void*, size_t);
static ssize_t (*next_readv)(int, const struct iovec*, int);
static ssize_t (*next_pread)(int, void*, size_t, off_t);
static ssize_t (*next_write)(int, const void*, size_t);
static ssize_t (*next_writev)(int, const struct iovec*, int);
static ssize_t (*next_pwrite)(int, const void*, size_t, off_t);
static int (*next_fsync)(int);
static int (*next_open)(const char*, int, ...);
static int (*next_open64)(const char*, int, ...);
static int (*next_mkdir)(const char*, mode_t);
static int (*next_rename)(const char*, const char*);
static int (*next_renameat2)(int, const char*, int, const char*, unsigned int);

static void copy_setting(const char* name, char* to, size_t size) {
  const char* value = getenv(name);
  snprintf(to, size, "%s", value != NULL ? value : "");
}

__attribute__((constructor)) static void begin(void) {
  next_read = dlsym(RTLD_NEXT, "read");
  next_readv = dlsym(RTLD_NEXT, "readv");
  next_pread = dlsym(RTLD_NEXT, "pread");
  next_write = dlsym(RTLD_NEXT, "write");
  next_writev = dlsym(RTLD_NEXT, "writev");
  next_pwrite = dlsym(RTLD_NEXT, "pwrite");
  next_fsync = dlsym(RTLD_NEXT, "fsync");
  next_open = dlsym(RTLD_NEXT, "open");
  next_open64 = dlsym(RTLD_NEXT, "open64");
  next_mkdir = dlsym(RTLD_NEXT, "mkdir");
  next_rename = dlsym(RTLD_NEXT, "rename");
  next_renameat2 = dlsym(RTLD_NEXT, "renameat2");
  copy_setting("DEEPSLAM_FAULT_BELOW", below, sizeof(below));
  copy_setting("DEEPSLAM_FAULT_COUNT", count_file, sizeof(count_file));
  const char* at = getenv("DEEPSLAM_FAULT_AT");
  if (at != NULL) fail_at = atol(at);
  const char* error = getenv("DEEPSLAM_FAULT_ERROR");
  if (error != NULL && strcmp(error, "ENOSPC") == 0) fail_error = ENOSPC;
  const char* calls = getenv("DEEPSLAM_FAULT_CALLS");
  of_reads = calls != NULL && strcmp(calls, "read") == 0;
}

__attribute__((destructor)) static void end(void) {
  if (count_file[0] == '\0') return;
  char text[64];
  const int size = snprintf(text, sizeof(text), "%ld %s\n", num_calls, failed_call);
  const int file = next_open(count_file, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file < 0) return;
  if (next_write(file, text, (size_t)size) < 0) return;
  close(file);
}

static int is_below(const char* path) {
  const size_t size = strlen(below);
  return size > 0 && strncmp(path, below, size) == 0;
}

static int is_file_below(int file) {
  if (below[0] == '\0') return 0;
  char link[64];
  char path[PATH_MAX];
  snprintf(link, sizeof(link), "/proc/self/fd/%d", file);
  const ssize_t size = readlink(link, path, sizeof(path) - 1);
  if (size < 0) return 0;
  path[size] = '\0';
  return is_below(path);
}

/* Whether this call fails. */
static int fails_of_kind(const char* call, int needs_space) {
  pthread_mutex_lock(&mutex);
  ++num_calls;
  int failing = 0;
  if (fail_at > 0) {
    failing = fail_error == ENOSPC ? num_calls >= fail_at && needs_space : num_calls == fail_at;
    if (failing && strcmp(failed_call, "none") == 0) failed_call = call;
  }
  pthread_mutex_unlock(&mutex);
  if (failing) errno = fail_error;
  return failing;
}

/* Of a call that writes. A full disk refuses what comes after as well, but for renames. */
static int fails(const char* call, int needs_space) { return !of_reads && fails_of_kind(call, needs_space); }

static int read_fails(int file, const char* call) { return of_reads && is_file_below(file) && fails_of_kind(call, 0); }

ssize_t read(int file, void* bytes, size_t size) {
  if (read_fails(file, "read")) return -1;
  return next_read(file, bytes, size);
}

ssize_t readv(int file, const struct iovec* parts, int count) {
  if (read_fails(file, "readv")) return -1;
  return next_readv(file, parts, count);
}

ssize_t pread(int file, void* bytes, size_t size, off_t at) {
  if (read_fails(file, "pread")) return -1;
  return next_pread(file, bytes, size, at);
}

ssize_t pread64(int file, void* bytes, size_t size, off_t at) { return pread(file, bytes, size, at); }

ssize_t write(int file, const void* bytes, size_t size) {
  if (is_file_below(file) && fails("write", 1)) return -1;
  return next_write(file, bytes, size);
}

ssize_t writev(int file, const struct iovec* parts, int count) {
  if (is_file_below(file) && fails("writev", 1)) return -1;
  return next_writev(file, parts, count);
}

ssize_t pwrite(int file, const void* bytes, size_t size, off_t at) {
  if (is_file_below(file) && fails("pwrite", 1)) return -1;
  return next_pwrite(file, bytes, size, at);
}

int fsync(int file) {
  if (is_file_below(file) && fails("fsync", 1)) return -1;
  return next_fsync(file);
}

int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  if ((flags & O_CREAT) != 0 && is_below(path) && fails("open", 1)) return -1;
  return next_open(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  if ((flags & O_CREAT) != 0 && is_below(path) && fails("open", 1)) return -1;
  return next_open64(path, flags, mode);
}

int mkdir(const char* path, mode_t mode) {
  if (is_below(path) && fails("mkdir", 1)) return -1;
  return next_mkdir(path, mode);
}

int rename(const char* from, const char* to) {
  if (is_below(from) && fails("rename", 0)) return -1;
  return next_rename(from, to);
}

int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned int flags) {
  if (is_below(from) && fails("renameat2", 0)) return -1;
  return next_renameat2(from_folder, from, to_folder, to, flags);
}
