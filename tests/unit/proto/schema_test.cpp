#include <gtest/gtest.h>

#include <set>

#include "daemon/shared/schemas/schemas.hpp"
#include "proto/method_list.hpp"
#include "proto/tables/calibration.hpp"
#include "proto/tables/description.hpp"
#include "proto/tables/devices.hpp"
#include "proto/tables/files.hpp"
#include "proto/tables/lattices.hpp"
#include "proto/tables/picture.hpp"
#include "proto/tables/set.hpp"
#include "proto/tables/status.hpp"
#include "proto/tables/streams.hpp"

namespace ovws {
namespace {

TEST(Schemas, AreOneForEachName) {
  std::set<std::string> names;
  for (const Schema& one : schemas()) EXPECT_TRUE(names.insert(one.name).second) << one.name;
  EXPECT_EQ(names.size(), kMethods.kSize + kStreams.kSize);
  EXPECT_TRUE(schema("camera.sett").is_null());
}

TEST(Schemas, GiveExamplesThatTheDecodersTake) {
  const auto check = [](const auto& method) {
    using P = typename std::remove_cvref_t<decltype(method)>::Params;
    for (const Json& params : schema(method.name).at("params").at("examples")) {
      EXPECT_TRUE(decode_params<P>(params)) << method.name << " " << params;
    }
  };
  kMethods.apply([&](const auto&... method) { (check(method), ...); });
}

}  // namespace
}  // namespace ovws
