# Builds the viewer from this folder into FOLDER, and then makes STAMP. Where its packages can't be had, it is
# left out, and tried again with the next build.
if(NOT EXISTS node_modules/.package-lock.json OR package-lock.json IS_NEWER_THAN node_modules/.package-lock.json)
  execute_process(
    COMMAND ${NPM} ci --no-audit --no-fund --fetch-retries=1 --loglevel=error
    RESULT_VARIABLE failed
    OUTPUT_VARIABLE told
    ERROR_VARIABLE told)
  if(failed)
    message("The viewer isn't built: 'npm ci' in viewer/ failed, perhaps for lack of a network. "
            "The service runs without it.\n${told}")
    return()
  endif()
endif()
execute_process(
  COMMAND ${NODE} node_modules/vite/bin/vite.js build --outDir ${FOLDER} --emptyOutDir --logLevel warn
  COMMAND_ERROR_IS_FATAL ANY)
file(TOUCH ${STAMP})
