#include "daemon/web/options.hpp"

#include <gtest/gtest.h>

namespace ovws::web {
namespace {

TEST(OptionsTest, TakesLoopbackAddressesApart) {
  Options options;
  ASSERT_TRUE(check_options(options));
  EXPECT_EQ(options.address, "127.0.0.1");
  EXPECT_EQ(options.port, 7704);
  EXPECT_EQ(options.hosts(), (std::vector<std::string>{"127.0.0.1:7704", "localhost:7704"}));
  options.listen = "[::1]:8080";
  options.more_hosts = {"bench.lab"};
  ASSERT_TRUE(check_options(options));
  EXPECT_EQ(options.address, "::1");
  EXPECT_EQ(options.hosts().back(), "bench.lab");
}

TEST(OptionsTest, RefusesWhatOthersReachUnlessItIsAskedFor) {
  Options options;
  for (const char* listen : {"0.0.0.0:7704", "192.168.1.5:7704", "[::]:7704"}) {
    options.listen = listen;
    const auto checked = check_options(options);
    ASSERT_FALSE(checked) << listen;
    EXPECT_EQ(checked.error().field, "--listen");
  }
  options.cleartext = true;
  EXPECT_TRUE(check_options(options));
}

TEST(OptionsTest, RefusesWhatIsNoAddress) {
  Options options;
  for (const char* listen :
       {"", ":", ":7704", "127.0.0.1", "127.0.0.1:", "127.0.0.1:0", "127.0.0.1:70000",
        "127.0.0.1:x", "127.0.0.1:7704x", "localhost:7704", "::1:7704"}) {
    options.listen = listen;
    EXPECT_FALSE(check_options(options)) << listen;
  }
}

}  // namespace
}  // namespace ovws::web
