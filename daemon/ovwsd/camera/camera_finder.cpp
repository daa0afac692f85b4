#include "daemon/ovwsd/camera/camera_finder.hpp"

#include <chrono>
#include <utility>

#include "daemon/ovwsd/devices/device_lists.hpp"

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kMaxIdle(50);

}  // namespace

void CameraFinder::list(Listed done) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    waiting_.push_back(std::move(done));
  }
  asked_.notify_one();
}

void CameraFinder::find(const std::string& id, std::function<void(Result<void>)> done) {
  list([this, id, done = std::move(done)](const std::vector<CameraListing>& listed) {
    CameraConfig wanted = config_();
    wanted.id = id;
    done(check_camera(wanted, listed));
  });
}

bool CameraFinder::do_work() {
  std::vector<Listed> asked;
  {
    std::unique_lock lock(mutex_);
    if (!asked_.wait_for(lock, kMaxIdle, [this] { return !waiting_.empty(); })) return false;
    asked.swap(waiting_);
  }
  const std::vector<CameraListing> listed = list_cameras(config_());
  for (const Listed& done : asked) done(listed);
  return true;
}

void CameraFinder::on_close() {
  std::vector<Listed> dropped;  // destroyed after the unlock
  const std::lock_guard lock(mutex_);
  closed_ = true;
  dropped.swap(waiting_);
}

}  // namespace ovws
