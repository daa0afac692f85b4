/// The twin's own methods: what tests and people read and change behind the daemon's back.
#pragma once

#include <optional>
#include <string>

#include "drivers/twin/bench.hpp"
#include "drivers/twin/fake_camera.hpp"
#include "drivers/twin/faults.hpp"
#include "drivers/twin/frame_source.hpp"
#include "drivers/twin/screen.hpp"
#include "drivers/twin/twin_config.hpp"
#include "proto/rpc.hpp"

namespace ovws::twin {

/// `twin.get`, `twin.set` and `twin.fault`; see drivers/twin/README.md for their keys.
class Methods {
 public:
  struct Deps {
    Bench& bench;
    FrameSource& frames;
    Faults& faults;
    const Screen& screen;
    const FakeCamera& camera;
  };
  Methods(const Config& config, const Deps& deps) : config_(config), deps_(deps) {}

  /// Control thread. `params` is an object.
  RpcAnswer call(const std::string& method, const Json& params);

 private:
  RpcAnswer get(const Json& params);
  RpcAnswer set(const Json& params);
  RpcAnswer fault(const Json& params);

  const Turbulence& turbulence(const TurbulenceConfig& config);

  const Config config_;
  const Deps deps_;
  std::optional<Turbulence> turbulence_;  ///< the one asked for last
};

}  // namespace ovws::twin
