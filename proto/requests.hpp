/// Decoding of params: strict, all or nothing.
///
/// Every error is Errc::invalid with the dotted path of the key at fault; see field_json.hpp.
#pragma once

#include "proto/tables/job.hpp"
#include "proto/tables/loop.hpp"
#include "proto/tables/params.hpp"
#include "proto/tables/record.hpp"
