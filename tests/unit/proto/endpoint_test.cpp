#include "proto/endpoint.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace ovws {
namespace {

TEST(Endpoint, IsAnAddressWithAPortOrAPath) {
  for (const char* good :
       {"tcp://127.0.0.1:1", "tcp://*:65535", "tcp://[::1]:7701", "tcp://eth0:7701",
        "tcp://bench.example.org:7701", "ipc:///run/ovws/a", "ipc://@name", "tcp://[::]:1",
        "tcp://[fe80::1%eth0]:1", "tcp://[::ffff:10.0.0.1]:1", "tcp://localhost:7701"}) {
    EXPECT_EQ(endpoint_fault(good), std::nullopt) << good;
  }
  EXPECT_EQ(endpoint_fault("ipc://" + std::string(107, 'a')), std::nullopt);
}

TEST(Endpoint, SaysWhatATextLacks) {
  for (const char* wrong : {"",
                            "tcp://",
                            "tcp://127.0.0.1",
                            "tcp://:7701",
                            "tcp://127.0.0.1:0",
                            "tcp://*:65536",
                            "tcp://*:99999",
                            "tcp://*:-1",
                            "tcp://*:77o1",
                            "tcp://*:*",
                            "udp://127.0.0.1:1",
                            "127.0.0.1:7701",
                            "ipc://",
                            "ipc://*",
                            "TCP://127.0.0.1:1",
                            "inproc://a",
                            "tcp://::1:7701",
                            "tcp://[::1:7701",
                            "tcp://::1]:7701",
                            "tcp://[]:7701",
                            "tcp://[127.0.0.1]:7701",
                            "tcp://[::1]x:7701",
                            "tcp://[name]:7701"}) {
    const auto fault = endpoint_fault(wrong);
    ASSERT_TRUE(fault) << wrong;
    EXPECT_EQ(fault->find("\"" + std::string(wrong) + "\""), 0U) << *fault;
  }
  EXPECT_TRUE(endpoint_fault("ipc://" + std::string(108, 'a')));
}

TEST(Endpoint, OfASocketIsAnAddress) {
  for (const char* good :
       {"tcp://127.0.0.1:1", "tcp://*:1", "tcp://eth0:1", "tcp://[::]:1", "ipc:///localhost"}) {
    EXPECT_EQ(bind_fault(good), std::nullopt) << good;
  }
  EXPECT_EQ(bind_fault("tcp://localhost:7701"),
            "\"tcp://localhost:7701\" is a name: give the address, tcp://127.0.0.1:7701");
  EXPECT_EQ(bind_fault("tcp://"), endpoint_fault("tcp://"));
}

TEST(Endpoint, IsIpv6InBracketsOnly) {
  for (const char* yes : {"tcp://[::1]:7701", "tcp://[::]:1", "tcp://[fe80::1%eth0]:1"}) {
    EXPECT_TRUE(is_ipv6(yes)) << yes;
  }
  for (const char* no : {"tcp://127.0.0.1:1", "tcp://*:1", "tcp://localhost:1", "ipc://[::1]:1"}) {
    EXPECT_FALSE(is_ipv6(no)) << no;
  }
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
