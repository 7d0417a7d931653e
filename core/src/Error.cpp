#include "isofront/core/Result.h"

namespace isofront::core {

Error Error::within(const std::string& context) const
{
    return {code, context + ": " + message};
}

} // namespace isofront::core
