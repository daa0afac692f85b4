/// Control methods of the twin. Tests and users read and change the ground truth with them, which
/// the daemon cannot see.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/twin/bench.hpp"
#include "drivers/twin/fake_camera.hpp"
#include "drivers/twin/faults.hpp"
#include "drivers/twin/frame_source.hpp"
#include "drivers/twin/judge.hpp"
#include "drivers/twin/screen.hpp"
#include "drivers/twin/twin_config.hpp"
#include "proto/rpc.hpp"

namespace ovws::twin {

/// Control methods `twin.get`, `twin.set`, `twin.mirror` and `twin.fault`; drivers/twin/README.md
/// lists the keys.
class Methods {
 public:
  struct Deps {
    Bench& bench;
    FrameSource& frames;
    Faults& faults;
    Screen& screen;
    const FakeCamera& camera;
  };
  Methods(const Config& config, const Deps& deps);

  /// Executes a request. Control thread only. `params` must be a JSON object.
  RpcAnswer call(const std::string& method, const Json& params);

 private:
  RpcAnswer get(const Json& params);
  RpcAnswer set(const Json& params);
  RpcAnswer fault(const Json& params);
  RpcAnswer mirror(const Json& params);

  const Turbulence& turbulence(const TurbulenceConfig& config);
  /// Adds to `result` the judge's verdict on the image that the X server shows now.
  void add_verdict(Pattern pattern, const Truth& truth, std::int64_t t_ns, Json& result);

  const Config config_;
  const Deps deps_;
  const std::vector<Vec2> actuators_;     ///< positions in pupil radii; empty: there is no mirror
  std::optional<Turbulence> turbulence_;  ///< cached for the newest configuration
  std::unique_ptr<Judge> judge_;          ///< created at the first verdict
};

}  // namespace ovws::twin
