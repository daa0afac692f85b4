/// Mutex with priority inheritance, for locks that real-time threads share with others.
#pragma once

#include <pthread.h>

#include <mutex>

namespace ovws {

/// std::mutex with PTHREAD_PRIO_INHERIT: a thread that holds it runs at the priority of the most
/// urgent thread that waits for it, so no other thread delays it. It still blocks: hold it for a
/// few instructions only. Without support by the kernel it is an ordinary mutex.
class PriorityMutex : public std::mutex {
 public:
  PriorityMutex() {
    pthread_mutexattr_t attributes;
    pthread_mutexattr_init(&attributes);
    pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
    // std::mutex takes no attributes; its native mutex is not in use yet.
    pthread_mutex_init(native_handle(), &attributes);
    pthread_mutexattr_destroy(&attributes);
  }
  ~PriorityMutex() { pthread_mutex_destroy(native_handle()); }
};

}  // namespace ovws
