/// Endpoints that no other test uses: an ipc path of this process, and a free port of loopback.
#pragma once

#include <unistd.h>

#include <string>

namespace ovws::test {

inline std::string ipc_endpoint(const std::string& name) {
  return "ipc:///tmp/ovws-test-" + std::to_string(::getpid()) + "-" + name;
}

}  // namespace ovws::test
