/// Field tables of a designed bench, for JSON.
#pragma once

#include "daemon/ovws/design/design.hpp"
#include "proto/field_json.hpp"

namespace ovws {

template <>
inline constexpr NamesOf kNames<design::Limit> =
    texts<"region", "neighbours", "scale", "grating", "orders", "modes", "beam">;

template <>
inline constexpr auto kTable<design::Finding> =
    Fields{"Finding", field<&design::Finding::limit>("what limits the bench"),
           field<&design::Finding::reason>("what it means here"),
           field<&design::Finding::help>("what helps").or_null()};

template <>
inline constexpr auto kTable<design::Change> =
    Fields{"Change", field<&design::Change::options>("options that replace the given ones"),
           field<&design::Change::meaning>("what they mean")};

template <>
inline constexpr auto kTable<design::Figures> = Fields{
    "Figures",
    field<&design::Figures::subapertures>("number of subapertures"),
    field<&design::Figures::modes>("number of modes that are measured"),
    field<&design::Figures::modes_by_positions>(
        "number of modes that the spots' positions determine"),
    field<&design::Figures::pupil_mm>("diameter that the beam must cover, millimetres"),
    field<&design::Figures::subaperture_mm>("diameter of a subaperture, millimetres"),
    field<&design::Figures::subaperture_px>("diameter of a subaperture, SLM pixels"),
    field<&design::Figures::lambda_d_px>("scale of one spot, camera pixels"),
    field<&design::Figures::neighbours>("smallest distance of two spots, lambda/d"),
    field<&design::Figures::range_waves>(
        "slope over one subaperture that a spot can follow, waves"),
    field<&design::Figures::range_defocus_waves>("coefficient of Z(2,0) with that slope, waves"),
    field<&design::Figures::grating_period_px>("period of the base grating, SLM pixels"),
    field<&design::Figures::finest_period_px>("period of the finest grating, SLM pixels"),
    field<&design::Figures::zeroth_order_px>(
        "from the zeroth order to the base spot, camera pixels"),
    field<&design::Figures::zeroth_order_mm>(
        "from the zeroth order to the base spot, millimetres on the camera")};

}  // namespace ovws
