// LD_PRELOAD library that simulates a slow or blocked disk for one process.
//
// $OVWS_SLOW_FOLDER is the folder on that disk. $OVWS_SLOW_DISK is a file elsewhere with its speed
// in bytes per second: "0" blocks until the value changes; without the file the disk has its real
// speed. File system calls wait in this library as they would for a slow disk.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

/// Bytes per second; negative: real speed. Uses raw system calls, which this library does not
/// replace.
long speed() {
  static const char* const path = std::getenv("OVWS_SLOW_DISK");
  const long fd =
      path == nullptr ? -1 : ::syscall(SYS_openat, AT_FDCWD, path, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return -1;
  char text[32] = {};
  const long size = ::syscall(SYS_read, fd, text, sizeof(text) - 1);
  ::syscall(SYS_close, fd);
  return size > 0 ? std::strtol(text, nullptr, 10) : -1;
}

void sleep_s(double seconds) {
  const auto whole = time_t(seconds);
  const timespec time{whole, long(1e9 * (seconds - double(whole)))};
  ::nanosleep(&time, nullptr);
}

bool on_it(const char* path) {
  static const char* const folder = std::getenv("OVWS_SLOW_FOLDER");
  return folder != nullptr && path != nullptr && std::strstr(path, folder) != nullptr;
}

void wait_for_disk(const char* path, std::size_t bytes = 0) {
  long now = speed();
  if (now < 0 || !on_it(path)) return;
  for (; now == 0; now = speed()) sleep_s(0.005);
  if (now > 0) sleep_s(double(bytes) / double(now));
}

void wait_for_disk(int fd, std::size_t bytes = 0) {
  if (speed() < 0) return;
  char path[4096] = {};
  const std::string link = "/proc/self/fd/" + std::to_string(fd);
  if (::readlink(link.c_str(), path, sizeof(path) - 1) > 0) wait_for_disk(path, bytes);
}

template <class About>
int looked_up(const char* function, const char* path, About* about) {
  wait_for_disk(path);
  return next<int (*)(const char*, About*)>(function)(path, about);
}

}  // namespace

extern "C" {

ssize_t write(int fd, const void* bytes, size_t count) {
  wait_for_disk(fd, count);
  return ::syscall(SYS_write, fd, bytes, count);
}

ssize_t pwrite(int fd, const void* bytes, size_t count, off_t at) {
  wait_for_disk(fd, count);
  return ::syscall(SYS_pwrite64, fd, bytes, count, at);
}

ssize_t pwrite64(int fd, const void* bytes, size_t count, off64_t at) {
  return pwrite(fd, bytes, count, at);
}

int fsync(int fd) {
  wait_for_disk(fd);
  return int(::syscall(SYS_fsync, fd));
}

int rename(const char* from, const char* to) noexcept {
  wait_for_disk(from);
  return int(::syscall(SYS_rename, from, to));
}

int unlink(const char* path) noexcept {
  wait_for_disk(path);
  return int(::syscall(SYS_unlink, path));
}

int mkostemps(char* path, int suffix, int flags) {
  wait_for_disk(path);
  static const auto real = next<int (*)(char*, int, int)>("mkostemps");
  return real(path, suffix, flags);
}

int mkostemps64(char* path, int suffix, int flags) {
  return mkostemps(path, suffix, flags);
}

int stat(const char* path, struct stat* about) noexcept {
  return looked_up("stat", path, about);
}

int stat64(const char* path, struct stat64* about) noexcept {
  return looked_up("stat64", path, about);
}

int statvfs(const char* path, struct statvfs* about) noexcept {
  return looked_up("statvfs", path, about);
}

int statvfs64(const char* path, struct statvfs64* about) noexcept {
  return looked_up("statvfs64", path, about);
}

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const int mode = va_arg(more, int);
  va_end(more);
  wait_for_disk(path);
  return int(::syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

int open64(const char* path, int flags, ...) __attribute__((alias("open")));

FILE* fopen(const char* path, const char* mode) {
  wait_for_disk(path);
  static const auto real = next<FILE* (*)(const char*, const char*)>("fopen");
  return real(path, mode);
}

FILE* fopen64(const char* path, const char* mode) {
  wait_for_disk(path);
  static const auto real = next<FILE* (*)(const char*, const char*)>("fopen64");
  return real(path, mode);
}
}
