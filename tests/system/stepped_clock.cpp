// LD_PRELOAD library that steps the wall clock of one process.
//
// The file $OVWS_CLOCK_STEP holds two 64-bit integers: the nanoseconds added to the wall clock, and
// the number of waits with a wall-clock deadline, which a step would lengthen or shorten. The
// monotonic clock is unchanged, as with a real step.
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>

namespace {

struct Shared {
  std::atomic<std::int64_t> step_ns;
  std::atomic<std::int64_t> wall_waits;
};

Shared* open_shared() {
  const char* const path = std::getenv("OVWS_CLOCK_STEP");
  const int fd = path == nullptr ? -1 : ::open(path, O_RDWR | O_CLOEXEC);
  if (fd < 0) std::abort();
  void* const at = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  ::close(fd);
  if (at == MAP_FAILED) std::abort();
  return static_cast<Shared*>(at);
}

Shared& shared() {
  static Shared* const it = open_shared();
  return *it;
}

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

void count_wait() {
  shared().wall_waits.fetch_add(1);
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, struct timespec* now) noexcept {
  const long status = ::syscall(SYS_clock_gettime, clock, now);
  if (status != 0 || (clock != CLOCK_REALTIME && clock != CLOCK_REALTIME_COARSE))
    return int(status);
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t ns = now->tv_sec * kSecond + now->tv_nsec + shared().step_ns.load();
  now->tv_sec = ns / kSecond;
  now->tv_nsec = ns % kSecond;
  return 0;
}

time_t time(time_t* out) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (out != nullptr) *out = now.tv_sec;
  return now.tv_sec;
}

int gettimeofday(struct timeval* out, void* /*zone*/) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  out->tv_sec = now.tv_sec;
  out->tv_usec = now.tv_nsec / 1000;
  return 0;
}

int sem_timedwait(sem_t* semaphore, const struct timespec* until) {
  count_wait();
  static const auto real = next<int (*)(sem_t*, const timespec*)>("sem_timedwait");
  return real(semaphore, until);
}

int pthread_mutex_timedlock(pthread_mutex_t* mutex, const struct timespec* until) noexcept {
  count_wait();
  static const auto real =
      next<int (*)(pthread_mutex_t*, const timespec*)>("pthread_mutex_timedlock");
  return real(mutex, until);
}

int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                           const struct timespec* until) {
  if (clock == CLOCK_REALTIME) count_wait();
  static const auto real =
      next<int (*)(pthread_cond_t*, pthread_mutex_t*, clockid_t, const timespec*)>(
          "pthread_cond_clockwait");
  return real(condition, mutex, clock, until);
}
}
