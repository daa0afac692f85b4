/// Who asks for a change of a device.
#pragma once

namespace ovws {

/// A client's change is refused while a job, a reload, the loop or lattice.use depends on the
/// device. Their own changes are not: they hold the sensor.
enum class Asker { client, holder };

}  // namespace ovws
