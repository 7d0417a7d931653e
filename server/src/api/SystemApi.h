#pragma once

#include "../Service.h"

namespace isofront::server {

/// How the service fares, and what it can do: `/healthz`, `/metrics`, `/openapi.json`. The last
/// describes all that has been added until it is asked for.
Api systemApi(Service& service);

} // namespace isofront::server
