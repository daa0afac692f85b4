#include "daemon/ovwsd/camera/camera_finder.hpp"

#include <chrono>
#include <utility>

#include "daemon/ovwsd/devices/device_lists.hpp"

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kMaxIdle(50);

}  // namespace

void CameraFinder::list(Listed done) {
  mailbox_.post([this, done = std::move(done)] { waiting_.push_back(done); });
}

void CameraFinder::find(const std::string& id, std::function<void(Result<void>)> done) {
  list([this, id, done = std::move(done)](const std::vector<CameraListing>& listed) {
    CameraConfig wanted = config_();
    wanted.id = id;
    done(check_camera(wanted, listed));
  });
}

bool CameraFinder::do_work() {
  if (!mailbox_.run_one(kMaxIdle)) return false;
  while (mailbox_.run_one(std::chrono::milliseconds(0))) {
  }
  const std::vector<Listed> asked = std::exchange(waiting_, {});  // an exception drops them
  const std::vector<CameraListing> listed = list_cameras(config_());
  for (const Listed& done : asked) done(listed);
  return true;
}

}  // namespace ovws
