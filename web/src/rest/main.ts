/** The REST API as a page: Swagger UI on this console's own description, with requests to try. */

import SwaggerUI from "swagger-ui-dist/swagger-ui-es-bundle.js";
import "swagger-ui-dist/swagger-ui.css";
import "./rest.css";

async function show(): Promise<void> {
  const answer = await fetch("api/v1/openapi.json");
  if (answer.status === 401) {
    throw new Error("This console needs a login: log in on the console's page, then reload this one.");
  }
  if (!answer.ok) throw new Error(`The description cannot be read: the console answers ${answer.status}.`);
  const spec = (await answer.json()) as Record<string, unknown>;
  SwaggerUI({
    // Below this page, as the console may be reached through a proxy under a path.
    spec: { ...spec, servers: [{ url: new URL(".", location.href).href }] },
    dom_id: "#viewer",
    deepLinking: true,
    docExpansion: "list",
    defaultModelsExpandDepth: 0,
    displayRequestDuration: true,
    syntaxHighlight: false,
    validatorUrl: null, // its default sends the description to a server elsewhere
  });
}

show().catch((reason: unknown) => {
  document.querySelector(".problem")!.textContent = reason instanceof Error ? reason.message : String(reason);
});
