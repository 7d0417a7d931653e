#include "OutputFolder.h"

#include <system_error>

namespace isofront::cli {

namespace fs = std::filesystem;

OutputFolder::~OutputFolder()
{
    std::error_code ignored;
    for (auto folder = _made.rbegin(); folder != _made.rend(); ++folder)
        fs::remove(*folder, ignored); // fails for one that isn't empty
}

core::Result<void> OutputFolder::make(const fs::path& path)
{
    std::error_code failed;
    fs::path folder;
    for (const fs::path& part : path) {
        folder /= part;
        if (fs::create_directory(folder, failed))
            _made.push_back(folder);
        if (failed)
            return core::failure(
                core::ErrorCode::inputOutput,
                "--out " + path.string() + ": the folder can't be made (" + failed.message() +
                    "); choose another one");
    }
    return {};
}

} // namespace isofront::cli
