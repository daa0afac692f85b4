/// Tables of all params. decode_params (field_json.hpp) decodes them: strictly, all or nothing.
#pragma once

#include "proto/tables/job.hpp"
#include "proto/tables/loop.hpp"
#include "proto/tables/params.hpp"
#include "proto/tables/record.hpp"
