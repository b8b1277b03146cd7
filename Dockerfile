# The program in an image of Debian bookworm: `docker build -t deepslam .`; docs/installing.md says how it is run.
# The detector's weights are not in it (AGPL-3.0, see NOTICE): they are mounted at /data/weights.
ARG BASE=debian:bookworm-slim

FROM ${BASE} AS build
WORKDIR /src
# What is installed depends on these alone, and is kept while other sources change.
COPY scripts/setup.sh scripts/npm_files.sh scripts/
RUN scripts/setup.sh --no-weights
COPY . .
RUN scripts/build.sh release -DDEEPSLAM_TESTS=OFF && scripts/package.sh /packages
# Models of the CAD proposals, with the credit of each.
RUN build/release/tools/deepslam library build --data /data --withheld configs/withheld_models.yaml

FROM ${BASE}
LABEL org.opencontainers.image.title="deepslam" \
      org.opencontainers.image.description="RGB-D captures of rooms in, labelled object maps out" \
      org.opencontainers.image.licenses="GPL-3.0-or-later"
# Reading videos brings libraries for much else: drivers of graphics cards and their compiler, grids of map projections,
# names of languages. Nothing that the program loads needs these.
RUN printf 'path-exclude %s\n' '/usr/lib/*/dri/*' '/usr/lib/*/libLLVM-*' '/usr/lib/llvm-*' '/usr/lib/*/libz3.so*' \
      '/usr/lib/*/mfx/*' '/usr/lib/*/libmfxhw64.so*' '/usr/share/proj/*' '/usr/share/*iso-codes/*' '/usr/share/icons/*' \
      >/etc/dpkg/dpkg.cfg.d/unused
RUN --mount=type=bind,from=build,source=/packages,target=/packages \
    apt-get update && \
    apt-get install -y --no-install-recommends /packages/deepslam_*.deb && \
    rm -rf /var/lib/apt/lists/* /var/cache/apt/* && \
    useradd --create-home --uid 1000 deepslam
COPY --from=build /data /data
ENV DEEPSLAM_DATA=/data
USER deepslam
WORKDIR /home/deepslam
ENTRYPOINT ["deepslam"]
CMD ["--help"]
