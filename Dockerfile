# docker build --tag acf-jax .
# docker run --rm --user "$(id -u):$(id -g)" --volume "$PWD:/data" acf-jax diagnose my_rig --out diagnosis
FROM python:3.11-slim

WORKDIR /opt/acf-jax
COPY pyproject.toml README.md LICENSE constraints.txt ./
COPY src src
RUN pip install --no-cache-dir --constraint constraints.txt ".[excel,export,fleet,hdf5,mat,parquet,ros,tdms]"

# Compiled code is kept here between commands of one container; any user may write it.
ENV XDG_CACHE_HOME=/tmp/cache
WORKDIR /data
USER 65534
ENTRYPOINT ["acf-jax"]
CMD ["--help"]
