#include "proto/endpoint.hpp"

#include <gtest/gtest.h>

#include <string>

namespace ovws {
namespace {

TEST(Endpoint, IsAnAddressWithAPortOrAPath) {
  for (const char* good :
       {"tcp://127.0.0.1:1", "tcp://*:65535", "tcp://[::1]:7701", "tcp://eth0:7701",
        "tcp://bench.example.org:7701", "ipc:///run/ovws/a", "ipc://@name"}) {
    EXPECT_EQ(endpoint_fault(good), std::nullopt) << good;
  }
  EXPECT_EQ(endpoint_fault("ipc://" + std::string(107, 'a')), std::nullopt);
}

TEST(Endpoint, SaysWhatATextLacks) {
  for (const char* wrong :
       {"", "tcp://", "tcp://127.0.0.1", "tcp://:7701", "tcp://127.0.0.1:0", "tcp://*:65536",
        "tcp://*:99999", "tcp://*:-1", "tcp://*:77o1", "tcp://*:*", "udp://127.0.0.1:1",
        "127.0.0.1:7701", "ipc://", "ipc://*", "TCP://127.0.0.1:1", "inproc://a"}) {
    const auto fault = endpoint_fault(wrong);
    ASSERT_TRUE(fault) << wrong;
    EXPECT_EQ(fault->find("\"" + std::string(wrong) + "\""), 0U) << *fault;
  }
  EXPECT_TRUE(endpoint_fault("ipc://" + std::string(108, 'a')));
}

TEST(Endpoint, IsReachedFromHereOnlyByALoopbackAddressInNumbersOrAFile) {
  for (const char* here : {"tcp://127.0.0.1:7701", "tcp://127.0.0.0:1", "tcp://127.255.255.255:1",
                           "tcp://[::1]:7701", "ipc:///run/ovws/a", "ipc://a"}) {
    EXPECT_TRUE(is_reached_from_here_only(here)) << here;
  }
}

/// A host name may resolve to any address, and an abstract socket has no file permissions.
TEST(Endpoint, IsReachedByOthersOtherwise) {
  for (const char* others :
       {"tcp://*:7701", "tcp://0.0.0.0:7701", "tcp://126.0.0.1:1", "tcp://128.0.0.1:1",
        "tcp://10.127.0.1:1", "tcp://192.168.1.2:7701", "tcp://[::]:7701", "tcp://[::2]:1",
        "tcp://[::ffff:10.0.0.1]:1", "tcp://localhost:7701", "tcp://127.0.0.1.example.org:7701",
        "tcp://127.1:7701", "tcp://lo:7701", "tcp://127.0.0.1;10.0.0.1:7701", "tcp://:7701",
        "ipc://@name", "udp://127.0.0.1:7701", "127.0.0.1:7701", ""}) {
    EXPECT_FALSE(is_reached_from_here_only(others)) << others;
  }
}

TEST(Endpoint, BoundToAllAddressesIsDialledAtTheLoopbackAddress) {
  for (const auto& [bound, local] :
       {std::pair{"tcp://*:7702", "tcp://127.0.0.1:7702"},
        std::pair{"tcp://0.0.0.0:1", "tcp://127.0.0.1:1"},
        std::pair{"tcp://[::]:2", "tcp://[::1]:2"},
        std::pair{"tcp://192.168.1.2:7702", "tcp://192.168.1.2:7702"},
        std::pair{"ipc:///run/*:1", "ipc:///run/*:1"}, std::pair{"tcp:", "tcp:"}}) {
    EXPECT_EQ(local_endpoint(bound), local);
  }
}

}  // namespace
}  // namespace ovws
